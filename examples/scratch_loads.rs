//! scratch
use pushbelt_lab::loads::{Driven, LOADS};
use pushbelt_lab::variators::variator;
use pushbelt::variator::settings::{Inputs, RingModel};
use cpu_time::ThreadTime;
fn rate(a:&Inputs,b:&Inputs,h:f64)->Inputs{
  let mut r=Inputs::ZERO;
  r.primary.torque=(b.primary.torque-a.primary.torque)/h; r.secondary.torque=(b.secondary.torque-a.secondary.torque)/h;
  r.primary.clamping_force=(b.primary.clamping_force-a.primary.clamping_force)/h;
  r.secondary.clamping_force=(b.secondary.clamping_force-a.secondary.clamping_force)/h; r
}
fn main(){
  let args:Vec<String>=std::env::args().collect();
  let letters=&args[1]; let span:f64=args[2].parse().unwrap();
  let ratios:Vec<f64>=args[3].split(',').map(|x|x.parse().unwrap()).collect();
  let kinds=args[4].clone(); // eg A0 ramped r
  let modes=args.get(5).cloned().unwrap_or("hr".into());
  let tol:f64=args.get(6).map_or(1e-4,|x|x.parse().unwrap());
  for load in LOADS { if !letters.contains(load.letter()) {continue;}
   for (key,model) in [('A',RingModel::Ale),('0',RingModel::Ale0)] { if !kinds.contains(key){continue;}
    for ramped in [false,true]{ if !modes.contains(if ramped{'r'}else{'h'}){continue;}
     for &ratio in &ratios {
      let mut p=variator(model); p.solver.tolerance=tol;
      for extra in args.iter().skip(7){ let (k,v)=extra.split_once('=').unwrap(); let v:f64=v.parse().unwrap();
        match k {"v0"=>p.friction.velocity=v,"fall"=>p.friction.fall=v,"cells"=>p.mesh.cells_per_element=v as i32,"maxstep"=>p.solver.max_step=v,"rough"=>p.belt.roughness=v,"play"=>p.belt.play=v,"film"=>p.belt.film_force=v,"filmt"=>p.belt.film_thickness=v,"fr"=>p.friction.ring=v,"ke"=>p.belt.push_stiffness=v,"crough"=>p.contact.roughness=v,"cdamp"=>p.contact.damping=v,"bdamp"=>p.belt.damping=v,"zdamp"=>{p.primary.sheave_damping=v;p.secondary.sheave_damping=v},"ttime"=>{p.primary.tilt.time=v;p.secondary.tilt.time=v},_=>panic!()}}
      let mut d=Driven::new(load,p,ratio);
      let c0=d.variator.counts();
      let mut each=Vec::new(); let mut before=None;
      let mut fail=String::new();
      let steps=(span/load.step()).round() as usize; let mut slips=0;
      for _ in 0..steps { let t=ThreadTime::now(); let to=d.inputs(); let end=d.until();
        let (from,rates)= if ramped {let b=before.unwrap_or(to); (b,rate(&b,&to,load.step()))} else {(to,Inputs::ZERO)};
        before=Some(to);
        if let Err(e)=d.variator.advance_along(end,&from,&rates){fail=format!("{e}");break;}
        if d.variator.outputs().macro_slip {slips+=1;}
        each.push(t.elapsed().as_secs_f64()); }
      let sum:f64=each.iter().sum(); let c=d.variator.counts(); let o=d.variator.outputs().clone();
      each.sort_by(f64::total_cmp); let n=each.len(); if n==0 {println!("{fail}");continue;}
      let q=|s:f64| 1e3*each[(s*(n-1) as f64) as usize];
      let ms=n as f64*load.step()*1e3;
      println!("diff/fact {:.1} {} {:?} {} i={ratio}: {:6.2} x rt  med {:.2} 99% {:.2} 99.9% {:.2} max {:.2} ms | per ms: {:.2} steps {:.2} rej {:.2} fail {:.2} res {:.3} fact | ratio {:.3} slip {:.4} macro {:.3} {fail}",d.variator.system().differentiations() as f64 / (d.variator.counts().factorizations as f64),load.letter(),model,if ramped{"ramp"}else{"held"},ms*1e-3/sum,q(0.5),q(0.99),q(0.999),q(1.0),
       (c.steps-c0.steps) as f64/ms,(c.rejected-c0.rejected) as f64/ms,(c.failed-c0.failed) as f64/ms,(c.residuals-c0.residuals) as f64/ms,(c.factorizations-c0.factorizations) as f64/ms,o.ratio_geometric,o.slip,slips as f64/n as f64);
     }}}}
}
