"""The paper's sections 3 and 4 simulated, in both readings of its stiffness, beside its numbers.

Y. Lei, Y. Xia, Y. Huo, Influence of Electric Cylinder Transmission Characteristics on Servo System,
Mechanics & Industry 26, 15 (2025).
"""
