"""How often the diagnosis is right, on recordings of several generators that share no code."""
