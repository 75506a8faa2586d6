"""From the posterior over structures to the answer: names, corrected model, figures, verdict."""
