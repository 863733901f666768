"""Step loops of mechanisms, compiled whole: many steps in one call.

The integrators of integrate/ see y' = f(t, y) and numbers; these loops see a model, and use the
structure of its matrices.
"""
