"""The answer of a diagnosis: the result, its JSON, its page and its words, independent of how it was found."""
