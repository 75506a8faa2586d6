"""The equations of motion along measured motions: whether these fit them at all, residuals, noise, slopes."""
