"""The command line: what a user types becomes calls of the package, and what these return becomes text and files.

Given words, `main` runs one of the `commands` and gives back its exit code. A command reads its options, names all that
is wrong with them at once and before any work, calls the rooms below, and prints what came out (tables for people, or
JSON in full precision). It leaves pictures to `plotting`, files to `io` and the paper to `report`. No physics stands
here.
"""
