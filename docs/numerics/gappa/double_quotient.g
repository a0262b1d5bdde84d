# The quotient of two numbers of two parts (exact.md, section 6): q + rest is off by less than 25w² of itself.
# Both are scaled by powers of two to between 1 and 2.

@n = float<ieee_64, ne>;

inverse n= 1 / dh;
q n= th * inverse;
p n= q * dh;
e = -(p - q * dh);                    # what the product lacks, exactly
c = th - p;                           # exact: th and p differ by three roundings
k1 n= c - e;
k2 n= q * dl;
k3 n= tl - k2;
lacks n= k1 + k3;
rest n= lacks * inverse;

T = th + tl;
D = dh + dl;
LACKS = (c - e) + (tl - q * dl);      # T - q D
QUOTIENT = T / D;

{ th in [1, 2] /\ dh in [1, 2] /\ |tl| <= 1b-53 /\ |dl| <= 1b-53
  -> |((q + rest) - QUOTIENT) / QUOTIENT| <= BOUND }

# What cancels: th and p, then q and the quotient.
q - th / dh -> (q - th * inverse) + th * (inverse - 1 / dh) { dh <> 0 };
c -> -((p - q * dh) + (q - th / dh) * dh) { dh <> 0 };
e -> -(p - q * dh);
rest - lacks / dh -> (rest - lacks * inverse) + lacks * (inverse - 1 / dh) { dh <> 0 };
1 / dh - 1 / D -> dl / (dh * D) { dh <> 0, D <> 0 };
(q + rest) - QUOTIENT -> (rest - lacks / dh) + (lacks - LACKS) / dh + LACKS * (1 / dh - 1 / D)
  { dh <> 0, D <> 0 };

# In 16 by 16 parts.
$ th in 16, dh in 16;

# enough: 25b-106
# short:  15b-106
