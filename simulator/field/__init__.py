"""What a path carries: free segments, gains, motion within a beep."""
