"""The equations of motion along measured motions: plausibility of the data, residuals, noise, derivatives."""
