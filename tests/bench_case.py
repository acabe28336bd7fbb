"""A case in SI that only lacks its friction, for what a fit writes."""

BENCH = """
[machine]
kind = "pendulum-capsule"
pendulum_mass_kg = 0.5
pendulum_length_m = 0.3
capsule_mass_kg = 1.0
stiffness_N_m_per_rad = 2.0
damping_N_m_s_per_rad = 0.1
normal_load = "weight"
[drive]
waveform = "harmonic"
amplitude_N_m = 1.5
frequency_Hz = 1.0
"""
