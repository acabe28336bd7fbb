"""The lab: one HTML page in which a capsule moves while its sliders are dragged, with the bits of `simulate`.

Given a case, or the kinds of parts that it should offer, `bundle` makes the data of the page: kernels in WebAssembly by
form of system, records of parameters, presets with the numbers that they are checked by. `page` puts them, styles and
scripts (`web/`) into one file that asks nothing of any network.
"""
