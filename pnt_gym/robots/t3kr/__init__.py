"""The T3KR-class robot: kinematics and dynamics in closed form, its MuJoCo model, and motor references."""
