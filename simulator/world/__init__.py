"""A scene prepared for tracing: placed mirrors, visibility, candidate paths, rejections."""
