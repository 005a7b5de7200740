"""A toolkit for rclpy nodes that knows nothing of the fusion."""
