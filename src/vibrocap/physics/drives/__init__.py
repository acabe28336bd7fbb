"""Drives, one waveform per file."""
