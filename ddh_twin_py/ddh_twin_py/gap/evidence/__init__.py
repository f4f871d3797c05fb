"""What every signal answers to every parameter and effect about one place, and what each hypothesis has for it there."""
