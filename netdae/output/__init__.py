"""What a flight leaves behind: metrics, frames, trajectory, checkpoint."""
