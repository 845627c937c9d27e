"""The thesis' closed-loop simulations of a whole vehicle (section 5.2), its claims, and what they depend on."""
