"""How formulas become machine code: cached kernels, eight walkers in one number."""
