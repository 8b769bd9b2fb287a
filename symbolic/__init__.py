"""What the leg is: mechanism, effects, model, and the code generated from them."""
