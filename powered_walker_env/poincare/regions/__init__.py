"""From where is a gait reached, and from where can a fall be avoided?"""
