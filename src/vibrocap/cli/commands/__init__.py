"""The commands: each a function that takes what was typed and gives back its exit code, as `main` lists them.

A command with many options has a file beside it that makes of them one request, or all complaints at once.
"""
