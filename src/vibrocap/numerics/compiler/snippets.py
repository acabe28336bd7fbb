"""Pieces of LLVM's language that stand in a kernel where it asks for them: what LLVM has no instruction for."""

HELPERS = {
    # An int divided by 0 gives 0; the division of the least int by -1, which has no result, is none.
    "floor_divided": """define internal i64 @floor_divided(i64 %x, i64 %y) alwaysinline nounwind {
  %zero = icmp eq i64 %y, 0
  %minus = icmp eq i64 %y, -1
  %special = or i1 %zero, %minus
  %divisor = select i1 %special, i64 1, i64 %y
  %q = sdiv i64 %x, %divisor
  %r = srem i64 %x, %divisor
  %rest = icmp ne i64 %r, 0
  %signs = xor i64 %r, %divisor
  %opposite = icmp slt i64 %signs, 0
  %below = and i1 %rest, %opposite
  %one = zext i1 %below to i64
  %floor = sub i64 %q, %one
  %negated = sub i64 0, %x
  %ordinary = select i1 %minus, i64 %negated, i64 %floor
  %result = select i1 %zero, i64 0, i64 %ordinary
  ret i64 %result
}""",
    "floor_rest": """define internal i64 @floor_rest(i64 %x, i64 %y) alwaysinline nounwind {
  %zero = icmp eq i64 %y, 0
  %minus = icmp eq i64 %y, -1
  %special = or i1 %zero, %minus
  %divisor = select i1 %special, i64 1, i64 %y
  %r = srem i64 %x, %divisor
  %rest = icmp ne i64 %r, 0
  %signs = xor i64 %r, %divisor
  %opposite = icmp slt i64 %signs, 0
  %below = and i1 %rest, %opposite
  %added = add i64 %r, %divisor
  %result = select i1 %below, i64 %added, i64 %r
  ret i64 %result
}""",
    # As Python does it (`float_divmod` of its source).
    "float_rest": """define internal double @float_rest(double %x, double %y) alwaysinline nounwind {
  %r = frem double %x, %y
  %rest = fcmp une double %r, 0.0
  %negative_y = fcmp olt double %y, 0.0
  %negative_r = fcmp olt double %r, 0.0
  %differ = xor i1 %negative_y, %negative_r
  %sum = fadd double %r, %y
  %moved = select i1 %differ, double %sum, double %r
  %zero = call double @llvm.copysign.f64(double 0.0, double %y)
  %result = select i1 %rest, double %moved, double %zero
  ret double %result
}
declare double @llvm.copysign.f64(double, double)""",
    "float_floor_divided": """define internal double @float_floor_divided(double %x, double %y) alwaysinline nounwind {
  %none = fcmp oeq double %y, 0.0
  %r = frem double %x, %y
  %whole = fsub double %x, %r
  %div = fdiv double %whole, %y
  %rest = fcmp une double %r, 0.0
  %negative_y = fcmp olt double %y, 0.0
  %negative_r = fcmp olt double %r, 0.0
  %differ = xor i1 %negative_y, %negative_r
  %moves = and i1 %rest, %differ
  %less = fsub double %div, 1.0
  %q = select i1 %moves, double %less, double %div
  %some = fcmp une double %q, 0.0
  %floor = call double @llvm.floor.f64(double %q)
  %off = fsub double %q, %floor
  %far = fcmp ogt double %off, 0.5
  %next = fadd double %floor, 1.0
  %snapped = select i1 %far, double %next, double %floor
  %quotient = fdiv double %x, %y
  %zero = call double @llvm.copysign.f64(double 0.0, double %quotient)
  %ordinary = select i1 %some, double %snapped, double %zero
  %result = select i1 %none, double %quotient, double %ordinary
  ret double %result
}
declare double @llvm.copysign.f64(double, double)
declare double @llvm.floor.f64(double)""",
    # Repeated squaring, in the order in which a constant exponent is written out.
    "whole_power": """define internal double @whole_power(double %x, i64 %k) nounwind {
  %down = icmp slt i64 %k, 0
  %minus = sub i64 0, %k
  %times = select i1 %down, i64 %minus, i64 %k
  br label %next
next:
  %left = phi i64 [ %times, %0 ], [ %halved, %body ]
  %power = phi double [ 1.0, %0 ], [ %chosen, %body ]
  %square = phi double [ %x, %0 ], [ %squared, %body ]
  %over = icmp eq i64 %left, 0
  br i1 %over, label %done, label %body
body:
  %bit = and i64 %left, 1
  %odd = icmp ne i64 %bit, 0
  %product = fmul contract double %power, %square
  %chosen = select i1 %odd, double %product, double %power
  %halved = ashr i64 %left, 1
  %squared = fmul contract double %square, %square
  br label %next
done:
  %inverse = fdiv contract double 1.0, %power
  %result = select i1 %down, double %inverse, double %power
  ret double %result
}""",
}
