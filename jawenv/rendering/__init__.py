"""Pictures of one episode: side and front view of the jaw, the posteriors, comfort and the motion over time.

`renderer.Renderer` imports pygame when it draws for the first time.
"""
