"""What comes in, from messages to the arrays that the library takes."""
