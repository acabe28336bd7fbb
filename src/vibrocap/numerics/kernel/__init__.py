"""All that is compiled, and runs as plain Python too: three flat arrays in, the same arrays, further on, out.

A step is made (`step/`), events in it are found and cross the contact to its next mode (`events/`), the loop goes from
step to step and from run to run (`loop/`), or its caller moves it on (`loop/stepper`). Hooks record or measure what is
passed (`observe/`), with elementary functions of one lane or of all (`arithmetic/`). Where what stands in the arrays is
`memory_layout`; what the equations give is promised in `generated`. A law under an imposed motion has a kernel of its
own (`driven`, `driven_generated`).
"""
