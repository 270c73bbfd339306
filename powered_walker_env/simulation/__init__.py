"""How a stride is computed, from heel strike to heel strike, with its derivatives."""
