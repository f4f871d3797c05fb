"""What every node is built on: parameters, a clean start and stop, subscriptions in batches, progress."""
