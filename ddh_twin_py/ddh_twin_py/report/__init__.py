"""What people see: self-contained HTML, its JSON twin, the terminal summary."""
