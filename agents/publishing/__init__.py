"""What a trained policy is published as: a card and an ONNX graph."""
