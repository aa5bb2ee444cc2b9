//! scratch: LETTERS SPAN RATIOS KIND FIX STEP [k=v]
use pushbelt_lab::loads::{Driven, LOADS};
use pushbelt_lab::variators::variator;
use pushbelt::variator::settings::{Inputs, RingModel, Outputs, Parameters};
use pushbelt::variator::run::Variator;
use cpu_time::ThreadTime;
fn pick(o:&Outputs)->[f64;7]{[o.primary.speed,o.secondary.speed,o.ratio_geometric,o.slip,o.thrust_ratio,if o.macro_slip{1.0}else{0.0},o.energy_residual]}
fn rate(a:&Inputs,b:&Inputs,h:f64)->Inputs{
  let mut r=Inputs::ZERO;
  r.primary.torque=(b.primary.torque-a.primary.torque)/h; r.secondary.torque=(b.secondary.torque-a.secondary.torque)/h;
  r.primary.clamping_force=(b.primary.clamping_force-a.primary.clamping_force)/h;
  r.secondary.clamping_force=(b.secondary.clamping_force-a.secondary.clamping_force)/h; r
}
fn set(p:&mut Parameters,k:&str,v:f64){match k {"v0"=>p.friction.velocity=v,"fall"=>p.friction.fall=v,"rough"=>p.belt.roughness=v,"tol"=>p.solver.tolerance=v,_=>panic!()}}
fn main(){
  let args:Vec<String>=std::env::args().collect();
  let letters=&args[1]; let span:f64=args[2].parse().unwrap();
  let ratios:Vec<f64>=args[3].split(',').map(|x|x.parse().unwrap()).collect();
  let kinds=args[4].clone();
  let fixes:Vec<[usize;3]>=args[5].split('/').map(|f|{let v:Vec<usize>=f.split(',').map(|x|x.parse().unwrap()).collect();[v[0],v[1],v[2]]}).collect();
  let step:f64=args[6].parse().unwrap();
  let ramp=args[7]=="r";
  let reftol:f64=args[8].parse().unwrap();
  for load in LOADS { if !letters.contains(load.letter()) {continue;}
   for (key,model) in [('A',RingModel::Ale),('0',RingModel::Ale0)] { if !kinds.contains(key){continue;}
     for &ratio in &ratios {
      let mut p=variator(model); p.solver.tolerance=reftol;
      for extra in args.iter().skip(9){ let (k,v)=extra.split_once('=').unwrap(); if let Some(k)=k.strip_prefix('R'){set(&mut p,k,v.parse().unwrap())}}
      let mut d=Driven::new(load,p,ratio);
      let steps=(span/load.step()).round() as usize;
      let mut trace=Vec::new(); let mut reference=Vec::new();
      let mut q=variator(model);
      for extra in args.iter().skip(9){ let (k,v)=extra.split_once('=').unwrap(); if !k.starts_with('R'){set(&mut q,k,v.parse().unwrap())}}
      let mut e=Driven::new(load,q,ratio); let start=e.variator.clone();
      let t0=ThreadTime::now(); let mut before: Option<Inputs>=None;
      for _ in 0..steps { let i=d.inputs();
        let (from,rates)= if ramp {let b=before.unwrap_or(i); (b,rate(&b,&i,load.step()))} else {(i,Inputs::ZERO)}; before=Some(i);
        d.variator.advance_along(d.until(),&from,&rates).expect("ref"); trace.push((d.until(),from,rates)); reference.push(pick(d.variator.outputs())); }
      let tref=t0.elapsed().as_secs_f64();
      let moved=d.variator.ledger().moved;
      for &fix in &fixes {
       let mut v:Variator=start.clone(); v.set_fixed(fix,step);
       let c0=v.counts();
       let mut err=[0.0;5]; let mut slipdiff=0; let mut lo=[f64::MAX;5]; let mut hi=[f64::MIN;5]; let mut fail=String::new();let mut each=Vec::new();
       let mut worst=[0.0_f64;5];
       for ((t,i,r),re) in trace.iter().zip(&reference){
        let t0=ThreadTime::now();
        if let Err(x)=v.advance_along(*t,i,r){fail=format!("{x}");break;}
        let o=pick(v.outputs()); each.push(t0.elapsed().as_secs_f64());
        for k in 0..5 {err[k]+=(o[k]-re[k]).powi(2); worst[k]=worst[k].max((o[k]-re[k]).abs()); lo[k]=lo[k].min(re[k]); hi[k]=hi[k].max(re[k]);}
        if o[5]!=re[5]{slipdiff+=1;}
       }
       each.sort_by(f64::total_cmp); let n=each.len(); 
       let q=|s:f64| 1e3*each[(s*(n-1) as f64) as usize];
       let c=v.counts(); let ms=n as f64*load.step()*1e3; let o=v.outputs().clone();
       let text:Vec<String>=(0..5).map(|k| format!("{:.2}({:.3})",100.0*(err[k]/n as f64).sqrt()/(hi[k]-lo[k]).max(1e-9),worst[k])).collect();
       println!("{} {:?} i={ratio} {:?}: rms % wP wS i slip thrust {} range slip {:.4} thr {:.3} | macro diff {} of {} | energy {:.2} % | med {:.2} max {:.2} ms; per ms {:.1} res {:.2} fact; ref {:.2}x rt {fail}",load.letter(),model,fix,text.join(" "),hi[3]-lo[3],hi[4]-lo[4],slipdiff,n,100.0*o.energy_residual.abs()/moved,q(0.5),q(1.0),(c.residuals-c0.residuals) as f64/ms,(c.factorizations-c0.factorizations) as f64/ms,span/tref);
      }
     }}}
}
