"""What is missing: comparison, suspects, look-alikes, verdict, extension."""
