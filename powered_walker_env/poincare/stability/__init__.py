"""How stable is a gait, and how fast do deviations die out?"""
