"""Okabe and Ito's colours, which colour-blind readers can tell apart, and two more."""

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
VIOLET, GREY = "#5B3A8C", "#8C8C8C"
