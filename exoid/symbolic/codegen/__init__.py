"""From equations to compiled C: CasADi expressions, instructions, kernels, compiler and cache."""
