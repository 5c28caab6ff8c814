"""The reference: what there is to write with, and every complaint with its examples."""
