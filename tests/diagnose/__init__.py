"""What a diagnosis is made of, against independent simulations."""
