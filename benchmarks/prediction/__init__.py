"""What is predicted of every machine of configs/reality from its logs and one circle, held against what it does."""
