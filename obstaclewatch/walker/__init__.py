"""The walker's gait and the phone's pitch, as far as they show in the ground's echo."""
