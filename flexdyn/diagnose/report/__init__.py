"""What a diagnosis answers: the result, its JSON, its page and its words. It knows nothing of how it was found."""
