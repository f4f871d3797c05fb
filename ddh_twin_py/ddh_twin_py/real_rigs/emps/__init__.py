"""The electro-mechanical positioning system (EMPS) of Janot, Gautier and Brunot."""
