"""What may fail while a file is written: a full disk, a folder that refuses, a process that is killed."""
