"""Motions to excite a machine with: Fourier series, their extremes, and files of them."""
