"""The names of the ways from angles to accelerations; `exoid.measurement.signals.derivatives` has the ways themselves."""

BUTTERWORTH, SAVGOL, FOURIER = DERIVATIVES = "butterworth", "savgol", "fourier"
