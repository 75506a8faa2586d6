"""Reading in a process of its own, for libraries that damaged files crash: `caller` asks, `server` reads."""
