"""Bodies: where robots are, how they move and touch, what they sense, the charge they have.

This room reads the truth. Minds never import it.
"""
