# A volume of twice the digits, x·(y × z), of vectors that f64 holds (exact.md, section 6): off by 27w² of its
# permanent. What a sum or product lacks is known exactly; only the second parts are rounded. As in filter_edge.g,
# with the products of x1, which have the most roundings: 54w².

# The cross product: s and l.
p1 = mul_rel<53>(y2, z3);  q1 = mul_rel<53>(y3, z2);  s1 = sub_rel<53>(p1, q1);
p2 = mul_rel<53>(y3, z1);  q2 = mul_rel<53>(y1, z3);  s2 = sub_rel<53>(p2, q2);
p3 = mul_rel<53>(y1, z2);  q3 = mul_rel<53>(y2, z1);  s3 = sub_rel<53>(p3, q3);
c1 = -(s1 - (p1 - q1));  e1 = -(p1 - y2 * z3);  f1 = -(q1 - y3 * z2);
c2 = -(s2 - (p2 - q2));  e2 = -(p2 - y3 * z1);  f2 = -(q2 - y1 * z3);
c3 = -(s3 - (p3 - q3));  e3 = -(p3 - y1 * z2);  f3 = -(q3 - y2 * z1);
l1 = add_rel<53>(c1, sub_rel<53>(e1, f1));  L1 = c1 + (e1 - f1);
l2 = add_rel<53>(c2, sub_rel<53>(e2, f2));  L2 = c2 + (e2 - f2);
l3 = add_rel<53>(c3, sub_rel<53>(e3, f3));  L3 = c3 + (e3 - f3);

# The dot product: h, and what it lacks, nothing of which is fused.
h1 = mul_rel<53>(s1, x1);  g1 = -(h1 - s1 * x1);
h2 = mul_rel<53>(s2, x2);  g2 = -(h2 - s2 * x2);
h3 = mul_rel<53>(s3, x3);  g3 = -(h3 - s3 * x3);
h12 = add_rel<53>(h1, h2);  d1 = -(h12 - (h1 + h2));
h = add_rel<53>(h12, h3);   d2 = -(h - (h12 + h3));
lacks = add_rel<53>(add_rel<53>(d1, d2), add_rel<53>(add_rel<53>(g1, g2), g3));
LACKS = (d1 + d2) + ((g1 + g2) + g3);
low1 = add_rel<53>(mul_rel<53>(l1, x1), lacks);  LOW1 = L1 * x1 + LACKS;
low2 = add_rel<53>(mul_rel<53>(l2, x2), low1);   LOW2 = L2 * x2 + LOW1;
low = add_rel<53>(mul_rel<53>(l3, x3), low2);    LOW = L3 * x3 + LOW2;

v = h + low;
V = x1 * (y2 * z3 - y3 * z2) + x2 * (y3 * z1 - y1 * z3) + x3 * (y1 * z2 - y2 * z1);

{ |x1| <= 1 /\ |x2| <= 1b-80 /\ |x3| <= 1b-80 /\ |y1| <= 1 /\ |y2| <= 1 /\ |y3| <= 1 /\
  |z1| <= 1 /\ |z2| <= 1 /\ |z3| <= 1
  -> |v - V| <= BOUND }

v - V -> low - LOW;

# enough: 55b-106
# short:  53b-106
