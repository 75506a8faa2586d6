"""Reading in another process, for libraries that crash on damaged files: `caller` sends requests, `server` reads."""
