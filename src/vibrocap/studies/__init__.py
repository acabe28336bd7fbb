"""Questions asked of many motions: sweeps, their plans, their stores and their exports."""
