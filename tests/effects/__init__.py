"""Every effect of the catalogue against equations written a second time."""
