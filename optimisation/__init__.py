"""How numbers are found: fitness, optimisers, reference optimum with certificate, identification."""
