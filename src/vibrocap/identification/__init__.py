"""Identification: the parameters of friction laws from measurements, with what the measurements cannot say."""
