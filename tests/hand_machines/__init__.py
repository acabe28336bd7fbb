"""The machines of the package as they were derived by hand, the reference of those that are described."""
