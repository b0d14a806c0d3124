"""The only package that imports OCP: files and host objects in, solids and plain numpy descriptions out."""
