"""Publishing a trained policy: its card, its ONNX graph and the folder of both."""
