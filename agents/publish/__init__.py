"""The published folder of a trained policy: `python -m agents.publish` fills it with card, ONNX graph and film."""
