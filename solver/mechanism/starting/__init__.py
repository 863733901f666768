"""The state in which a run starts: assembled, quasi-static, in equilibrium or in steady spin."""
