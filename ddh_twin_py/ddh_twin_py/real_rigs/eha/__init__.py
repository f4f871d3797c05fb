"""An electro-hydraulic actuator: motor, reversible pump, asymmetric cylinder, valve and accumulator."""
