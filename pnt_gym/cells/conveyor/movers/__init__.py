"""How the hand moves through a pick: one file a mover, and a hand that rides with the belt around any of them."""
