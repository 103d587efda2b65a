"""The paper, reproduced: every figure of it from our own runs, beside what it claims."""
